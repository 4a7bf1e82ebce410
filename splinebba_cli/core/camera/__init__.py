"""From photo coordinates to rays: rotation, interior orientation, distortion, collinearity."""
