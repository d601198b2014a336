"""One file for each command; `pendpin NAME` runs the function of that name."""
