# Completion of vcell's commands, options and files for fish. What there is to complete comes from --help.
function __vcell_commands
    set -l line (commandline -opc)
    $line[1] --help 2>/dev/null | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]\+\)  *\(.*\)/\1\t\2/p'
end
function __vcell_options
    set -l line (commandline -opc)
    $line[1] $line[2] --help 2>/dev/null | sed -n 's/^  \(-[^ ]*\).*/\1/p' | tr ',' '\n'
end
function __vcell_has_command
    test (count (commandline -opc)) -gt 1
end
complete -c vcell -n 'not __vcell_has_command' -f -a '(__vcell_commands) --help --version'
complete -c vcell -n '__vcell_has_command; and string match -q -- "-*" (commandline -ct)' -a '(__vcell_options)'
