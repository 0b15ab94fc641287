"""The firmware's parameters: names, types, values, uploads of clients."""
