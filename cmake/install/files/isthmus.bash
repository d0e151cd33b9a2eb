# Completion for bash of isthmus and isthmus-server: the commands, options and values that their
# --help names. Nothing is listed here, so nothing is out of date here.

# Reads a help text: sets commands, options, choices and takes_value; the last two are of the option
# that $1 names.
_isthmus_read_help() {
  local line names rest section name
  commands=() options=() choices= takes_value=
  while IFS= read -r line; do
    case $line in
      Subcommands*:) section=commands ;;
      [A-Z]*:) section=options ;;
      '  -'*)
        names=${line#  } rest=
        if [[ $names == *' '* ]]; then
          rest=${names#* } names=${names%% *}
        fi
        for name in ${names//,/ }; do
          name=${name%%\{*}  # A flag's value: --no-finish{false}.
          options+=("$name")
          [[ $name == "$1" ]] || continue
          [[ $rest =~ ^(\[|[A-Z]{3,}([:= ]|$)) ]] && takes_value=yes
          [[ $rest =~ ^[A-Z]+:\{([^}]*)\} ]] && choices=${BASH_REMATCH[1]//,/ }
        done
        ;;
      '  '[a-z]*)
        line=${line#  }
        [[ $section == commands ]] && commands+=("${line%% *}")
        ;;
    esac
  done
}

_isthmus() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
  local path=("${COMP_WORDS[0]}") commands options choices takes_value word
  _isthmus_read_help "$previous" < <("${path[@]}" --help 2>/dev/null)
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    if [[ $word != -* && " ${commands[*]} " == *" $word "* ]]; then
      path+=("$word")
      _isthmus_read_help "$previous" < <("${path[@]}" --help 2>/dev/null)
    fi
  done
  COMPREPLY=()
  if [[ $choices ]]; then
    COMPREPLY=($(compgen -W "$choices" -- "$current"))
  elif [[ $current == -* ]]; then
    COMPREPLY=($(compgen -W "${options[*]}" -- "$current"))
  elif [[ ! $takes_value ]]; then
    COMPREPLY=($(compgen -W "${commands[*]}" -- "$current"))
  fi  # No reply: files.
}

complete -o default -F _isthmus isthmus isthmus-server isthmus-worker
