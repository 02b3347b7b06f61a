"""Files of a run, written while it goes on: `folder` names them, `Outputs` writes them."""
