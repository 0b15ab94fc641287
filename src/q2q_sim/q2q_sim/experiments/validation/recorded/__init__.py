"""What is read from a recorded flight: its references and states, the law of its vehicles, drag and noise."""
