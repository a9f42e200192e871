"""What the page of the explorer asks, and the answers: plain Python without a server, which holds no physics."""
