"""The commands: `pendpin NAME` runs the function of that name."""
