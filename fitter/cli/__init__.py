"""The command line, one file per subcommand. Modules here import only click at their top: `brdf --help` is instant."""
