#include "tools/ff/run_program.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace ff::tool {

Status run_program(const std::vector<std::string>& command) {
    std::vector<char*> arguments;
    for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
    pid_t pid = 0;
    const int error = posix_spawnp(&pid, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) return failure(fmt::format("{}: cannot be started: {}", command[0], std::strerror(error)));

    int state = 0;
    while (waitpid(pid, &state, 0) < 0)
        if (errno != EINTR) return failure(fmt::format("{}: lost sight of it: {}", command[0], std::strerror(errno)));
    if (WIFEXITED(state) && WEXITSTATUS(state) == 0) return {};
    return failure(fmt::format("{}: ended with {}; its own messages are above", fmt::join(command, " "),
                               WIFEXITED(state) ? fmt::format("exit code {}", WEXITSTATUS(state))
                                                : fmt::format("signal {}", WTERMSIG(state))));
}

}  // namespace ff::tool
