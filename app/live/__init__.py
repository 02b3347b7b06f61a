"""What watches and controls a run while it goes on."""
