"""What rigid wheels do on rails, and where a wheelset touches."""
