"""Extensions: what comes in by doors that every package may use, each in a folder of its own."""
