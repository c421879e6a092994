"""Commands that measure this machine and the methods: latency, and the documentation's tables."""
