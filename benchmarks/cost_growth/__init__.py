"""How the cost of each block grows with the number of vehicles: blocks, points, power laws, plots."""
