"""What a run looks like: figures, the HTML page with its player, the live view. Heavy imports are made late.

May import: model, scene, trajectory and what is below them.
To add a figure of a run: graphics/figure.py; something drawn in 3D:
graphics/run_drawing.py, its solids in graphics/shapes.py; a control of the player: graphics/player.
"""
