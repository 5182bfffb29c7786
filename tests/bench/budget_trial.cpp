// Whether budgets tell a lost tenth of one pass from this machine's noise: makes a budget of a walk, then holds it to
// runs of ff and, in turn, to runs of ff_planted that lose time in one of the limited passes.
//
//   budget_trial PACK WALK [RUNS [PERCENT [ARGUMENTS OF ff budget...]]]
//
// Prints a line a run and the counts. It times a machine: CTest never runs it.

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

namespace {

std::string read(const std::filesystem::path& path) {
    std::ifstream in(path);
    return {std::istreambuf_iterator<char>(in), {}};
}

struct Run {
    int exit_code;
    double seconds;
    std::string last_line;  ///< of what it said
};

Run run(const std::string& command, const std::filesystem::path& folder) {
    const auto begin = std::chrono::steady_clock::now();
    const std::filesystem::path log = folder / "log.txt";
    const int status = std::system((command + " 2>" + log.string() + " >/dev/null").c_str());
    std::string text = read(log);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1,
            std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
            text.substr(text.rfind('\n') + 1)};
}

/// Passes that the budget limits.
std::vector<std::string> limited_passes(const std::string& budget) {
    std::vector<std::string> passes;
    const std::regex line("(\\w+)\\.ms = .*");
    std::smatch found;
    bool in_passes = false;
    std::size_t at = 0;
    while (at < budget.size()) {
        const std::size_t end = std::min(budget.find('\n', at), budget.size());
        const std::string text = budget.substr(at, end - at);
        at = end + 1;
        if (text.rfind("[", 0) == 0) in_passes = text == "[passes]";
        // The plan is not a timed pass, and nothing is planted in it.
        if (in_passes && std::regex_match(text, found, line) && found[1] != "plan") passes.push_back(found[1]);
    }
    return passes;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: budget_trial PACK WALK [RUNS [PERCENT [ARGUMENTS OF ff budget...]]]\n");
        return 2;
    }
    const int runs = argc > 3 ? std::atoi(argv[3]) : 20;
    const std::string percent = argc > 4 ? argv[4] : "10";
    std::string arguments = std::string(" budget ") + argv[1] + " --walk " + argv[2];
    for (int i = 5; i < argc; ++i) arguments += std::string(" ") + argv[i];
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("farfield-budget-trial-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    const std::string budget = (folder / "budget.toml").string();
    const Run made = run(FF_BINARY + arguments + " --write " + budget, folder);
    if (made.exit_code != 0) {
        std::fprintf(stderr, "%s\n", made.last_line.c_str());
        return 1;
    }
    const std::string text = read(budget);
    const std::vector<std::string> passes = limited_passes(text);
    std::printf("%smade in %.1f s\n", text.c_str(), made.seconds);
    if (passes.empty()) {
        std::fprintf(stderr, "no pass is limited: nothing to plant a loss in\n");
        return 1;
    }
    arguments += " --budget " + budget + " --keep " + (folder / "miss").string();
    int alarms = 0, caught = 0;
    for (int i = 0; i < runs; ++i) {
        const Run clean = run(FF_BINARY + arguments, folder);
        alarms += clean.exit_code != 0;
        std::printf("%2d without        exit %d, %5.1f s%s%s\n", i, clean.exit_code, clean.seconds,
                    clean.exit_code != 0 ? ": " : "", clean.exit_code != 0 ? clean.last_line.c_str() : "");
        const std::string& pass = passes[std::size_t(i) % passes.size()];
        const Run lossy = run(FF_PLANTED_BINARY " " + pass + ":" + percent + arguments, folder);
        caught += lossy.exit_code == 4;
        std::printf("%2d %-9s +%s %% exit %d, %5.1f s: %s\n", i, pass.c_str(), percent.c_str(), lossy.exit_code,
                    lossy.seconds, lossy.last_line.c_str());
        std::fflush(stdout);
    }
    std::printf("%d of %d losses of %s %% caught; %d alarms in %d runs without\n", caught, runs, percent.c_str(),
                alarms, runs);
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
    return 0;
}
