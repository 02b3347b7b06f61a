"""What a person touches: the command line, the session, the recorder and the benches."""
