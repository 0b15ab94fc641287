"""Long flights through nodes whose memory, handles, bag and clock are watched."""
