"""The significance of effects: what each one changes and costs, and which ones an accuracy needs (`pendpin effects`).

May import: simulation and what is below it; no other tool.
"""
