"""Characters that play on a page without a server: bodies and motions as text, and the script that draws them."""
