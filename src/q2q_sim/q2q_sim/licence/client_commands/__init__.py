"""What a program asks of its vehicles: commands in words, and plans out of reach."""
