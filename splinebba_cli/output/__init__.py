"""Result folders: JSON, tables, dispersion, written atomically."""
