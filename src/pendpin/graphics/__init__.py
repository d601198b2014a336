"""What a run looks like: figures, the HTML page with its player, the live view. Heavy imports are made late.

May import: model, scene, trajectory and what is below them.
To add a panel to the figure of a run: graphics/figure.py; something drawn in 3D: graphics/run_drawing.py; a control of the
player: graphics/player; a row of what is said of a run: graphics/report.py.
"""
