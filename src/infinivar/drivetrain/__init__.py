"""Complete drive-trains, composed from elements and parts."""
