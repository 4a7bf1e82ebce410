"""Reports for people: what is said (sections, figures) and how (text, HTML)."""
