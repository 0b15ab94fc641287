"""State estimation from motion capture: gates, data association, Kalman filter, attitudes."""
