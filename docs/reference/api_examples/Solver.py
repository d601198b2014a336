import pendpin as pp

by_tolerance = pp.Solver(method="dop853", tolerance=1e-10, samples=601)
by_step = pp.Solver(method="gauss4", step=0.01)  # s
by_accuracy = pp.Solver(accuracy=1e-8)
