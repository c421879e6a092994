"""Wake-up latency and computing time of the loop, compared with the best that this machine can do."""
