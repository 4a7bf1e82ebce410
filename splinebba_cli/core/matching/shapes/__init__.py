"""From fragments to tie splines: joining, ordering, knots, splitting, duplicates, weak parts."""
