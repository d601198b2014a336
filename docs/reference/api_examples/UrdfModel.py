import pendpin as pp

arm = pp.UrdfModel("ur5", lock={"elbow_joint": 0.1})  # rad
scene = pp.Scene(model=arm, effects=[pp.effects.Gravity()], duration=0.5)
print(pp.simulate(scene, tolerance=1e-8).joints)
