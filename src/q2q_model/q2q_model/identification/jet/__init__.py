"""Jets fitted to measured downwash: form, fit, deviation, growth with thrust, and score on other flights."""
