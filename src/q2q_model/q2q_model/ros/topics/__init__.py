"""Topics: message types, qualities of service, deadlines, publishers of each vehicle."""
