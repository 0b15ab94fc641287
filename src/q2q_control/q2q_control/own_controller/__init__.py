"""Controller of a user's class, named as `module:Class`: found, and every command checked."""
