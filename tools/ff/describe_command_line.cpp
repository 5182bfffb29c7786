#include "tools/ff/describe_command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <vector>

namespace ff::tool {
namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App* command) { return !command->get_group().empty(); });
}

std::vector<const CLI::Option*> options_of(const CLI::App& app, bool positional) {
    return app.get_options([positional](const CLI::Option* option) { return option->get_positional() == positional; });
}

/// "-o", "--output".
std::vector<std::string> names_of(const CLI::Option& option) {
    std::vector<std::string> names;
    for (const std::string& name : option.get_snames()) names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
    return names;
}

bool takes_value(const CLI::Option& option) {
    return option.get_expected_max() > 0;
}

/// The values that an option may have, where its description lists them: "TEXT:{winner,random}".
std::vector<std::string> values_of(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    const std::size_t begin = type.find('{'), end = type.find('}');
    if (begin == std::string::npos || end == std::string::npos || end < begin) return {};
    std::vector<std::string> values = CLI::detail::split(type.substr(begin + 1, end - begin - 1), ',');
    // Where values stand for others they are listed as name->value.
    for (std::string& value : values) value = value.substr(0, value.find("->"));
    return values;
}

template <class List>
std::string joined(const List& list, const char* separator) {
    return fmt::format("{}", fmt::join(list, separator));
}

/// The names of all options of a command, in a line.
std::string option_words(const CLI::App& command) {
    std::vector<std::string> words;
    for (const CLI::Option* option : options_of(command, false))
        for (const std::string& name : names_of(*option)) words.push_back(name);
    return joined(words, " ");
}

std::string roff(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '-' || c == '\\') out += '\\';
        out += c == '\\' ? 'e' : c;
    }
    // A dot or quote at the beginning of a line is a request.
    return !out.empty() && (out[0] == '.' || out[0] == '\'') ? "\\&" + out : out;
}

std::string roff_options(const CLI::App& command) {
    std::string out;
    for (const CLI::Option* option : options_of(command, true))
        out += fmt::format(".TP\n.I {}\n{}\n", roff(option->get_name(true)), roff(option->get_description()));
    for (const CLI::Option* option : options_of(command, false)) {
        const std::vector<std::string> values = values_of(*option);
        std::string value;
        if (takes_value(*option))
            value = values.empty() ? " \\fIVALUE\\fR" : " \\fI" + joined(values, "\\fR|\\fI") + "\\fR";
        out += fmt::format(".TP\n.BR \"{}\"{}\n{}\n", roff(joined(names_of(*option), ", ")),
                           value.empty() ? "" : " \"" + value + "\"", roff(option->get_description()));
    }
    return out;
}

/// What stands under a command's options, as it stands.
std::string roff_footer(const CLI::App& command) {
    const std::string text = command.get_footer();
    if (text.empty()) return {};
    std::string out = ".PP\n.nf\n";
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        out += roff(text.substr(at, end - at)) + "\n";
        at = end + 1;
    }
    return out + ".fi\n";
}

/// A text in single quotes of the shell.
std::string quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

}  // namespace

std::string manual_page(const CLI::App& app) {
    std::string out = ".TH FF 1 \"\" \"Farfield " FF_VERSION "\" \"User Commands\"\n";
    out += ".SH NAME\nff \\- cook worlds for Farfield, walk through them, play and measure them\n";
    out += ".SH SYNOPSIS\n";
    for (const CLI::App* command : commands_of(app)) {
        std::string arguments;
        for (const CLI::Option* option : options_of(*command, true))
            arguments += " \\fI" + roff(option->get_name(true)) + "\\fR";
        out += fmt::format(".B ff {}\n[\\fIOPTION\\fR ...]{}\n.br\n", command->get_name(), arguments);
    }
    out += ".SH DESCRIPTION\n" + roff(app.get_description()) + "\n.SH COMMANDS\n";
    for (const CLI::App* command : commands_of(app))
        out += fmt::format(".SS ff {}\n{}.\n{}", command->get_name(), roff(command->get_description()),
                           roff_options(*command) + roff_footer(*command));
    out +=
        ".SH EXIT STATUS\n.TP\n.B 0\nall went well\n.TP\n.B 1\nthe system failed, or ff did\n.TP\n.B 2\n"
        "the command line is wrong\n.TP\n.B 3\na file is not what it should be; the message names file and place\n"
        ".TP\n.B 4\na budget or limit was missed\n";
    out +=
        ".SH ENVIRONMENT\n.TP\n.B XDG_CACHE_HOME\nwhere farfield/ keeps what can be cooked again (~/.cache)\n"
        ".TP\n.B XDG_DATA_HOME\nwhere games keep settings, saved games and recordings (~/.local/share)\n";
    return out;
}

std::string bash_completion(const CLI::App& app) {
    std::vector<std::string> names;
    std::string values, options;
    for (const CLI::App* command : commands_of(app)) {
        names.push_back(command->get_name());
        options += fmt::format("        {}) options={} ;;\n", command->get_name(), quoted(option_words(*command)));
        for (const CLI::Option* option : options_of(*command, false))
            if (const auto choices = values_of(*option); !choices.empty())
                for (const std::string& name : names_of(*option))
                    values += fmt::format("        '{} {}') values={} ;;\n", command->get_name(), name,
                                          quoted(joined(choices, " ")));
    }
    return fmt::format(R"(# bash completion for ff; made by `ff completion bash`
_ff() {{
    local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} command=${{COMP_WORDS[1]}}
    local values='' options=''
    if [ "$COMP_CWORD" -eq 1 ]; then
        COMPREPLY=($(compgen -W {} -- "$current"))
        return
    fi
    case "$command $before" in
{}    esac
    case "$command" in
{}    esac
    if [ -n "$values" ]; then
        COMPREPLY=($(compgen -W "$values" -- "$current"))
    elif [[ $current == -* ]]; then
        COMPREPLY=($(compgen -W "$options" -- "$current"))
    else
        compopt -o filenames
        COMPREPLY=($(compgen -f -- "$current"))
    fi
}}
complete -F _ff ff
)",
                       quoted(joined(names, " ") + " --help --version"), values, options);
}

std::string zsh_completion(const CLI::App& app) {
    /// Within a specification of _arguments, brackets and colons have a meaning.
    const auto described = [](const std::string& text) {
        std::string out;
        for (const char c : text) {
            if (c == '[' || c == ']' || c == ':') out += '\\';
            out += c;
        }
        return out;
    };
    std::string names, cases;
    for (const CLI::App* command : commands_of(app)) {
        names += "        " + quoted(command->get_name() + ":" + described(command->get_description())) + "\n";
        std::string arguments;
        for (const CLI::Option* option : options_of(*command, false)) {
            const auto choices = values_of(*option);
            const std::string value =
                !takes_value(*option) ? ""
                                      : (choices.empty() ? ":value:_files" : ":value:(" + joined(choices, " ") + ")");
            for (const std::string& name : names_of(*option))
                arguments += " \\\n                " +
                             quoted(fmt::format("{}[{}]{}", name, described(option->get_description()), value));
        }
        cases += fmt::format("        {})\n            _arguments{} \\\n                '*:file:_files' ;;\n",
                             command->get_name(), arguments);
    }
    return fmt::format(R"(#compdef ff
# zsh completion for ff; made by `ff completion zsh`
_ff() {{
    local -a commands=(
{}    )
    if (( CURRENT == 2 )); then
        _describe command commands
        return
    fi
    local command=$words[2]
    shift words
    (( CURRENT-- ))
    case $command in
{}    esac
}}
_ff "$@"
)",
                       names, cases);
}

}  // namespace ff::tool
