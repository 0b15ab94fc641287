"""What the documentation shows: pictures, the moving picture and the pages of the nodes."""
