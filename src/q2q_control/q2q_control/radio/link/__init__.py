"""Link to a real vehicle by cflib: setpoints in the units of the Crazyflie, packets, firmware parameters."""
