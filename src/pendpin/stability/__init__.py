"""What happens near a motion: linear models, natural modes, stability (docs/stability.md).

May import: motions, runs, graphics and what is below them; no other tool.
To add a question about a motion: a file with one public function that takes a scene, and a record of its answer.
"""
