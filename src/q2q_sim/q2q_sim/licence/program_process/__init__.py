"""Process of a program: clock, threads and links that end at the emulated vehicles."""
