"""What the documentation site does beyond Sphinx: pages stay plain Markdown that any viewer renders."""
