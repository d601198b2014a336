"""The double pendulum of example-robot-data: found in the installed package, checked, run, animated."""

from pathlib import Path

import pinocchio

import pendpin as pp

prefix = Path(pinocchio.__file__).parents[4]  # of the packages that Pinocchio came with
urdf = prefix / "share/example-robot-data/robots/double_pendulum_description/urdf/double_pendulum_simple.urdf"

scene = pp.Scene(
    duration=5.0,  # s
    model=pp.UrdfModel(path=urdf),
    start=pp.Start(positions=[0.5, 0.3]),  # rad, in model order
    effects=[pp.effects.Gravity()],
)
report = pp.crosscheck(scene, states=200)
run = pp.simulate(scene, tolerance=1e-12)
print(f"joints        {', '.join(run.joints)}")
print(f"cross-check   {report.worst.relative:.1e} between {' and '.join(report.routes)}")
print(f"energy drift  {run.energy().drift:.1e}")
