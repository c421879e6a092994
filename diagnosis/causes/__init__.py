"""How causes are looked for that need more than their declaration says (stillarm.common.causes): a file for
each of them."""
