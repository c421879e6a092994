"""How late the loop wakes and how long it computes, beside what this machine can do at best."""
