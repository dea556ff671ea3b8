"""Pure arrays in, arrays out: knows no USD and no renderer."""
