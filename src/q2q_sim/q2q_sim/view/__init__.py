"""Live view: scene of plain shapes, trails, Foxglove server."""
