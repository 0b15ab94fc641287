"""Documents: YAML and JSON text, plain values, frozen dataclasses made of them, folders of shipped files."""
