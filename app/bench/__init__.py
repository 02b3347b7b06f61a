"""Figures that anybody can repeat: each bench is a command and prints the table it measured."""
