"""Topics: message types, qualities of service, publishers of each vehicle."""
