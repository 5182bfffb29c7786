#include "tools/ff/playtest_options.h"

namespace ff::tool {

void add_budget_options(CLI::App& app, BudgetOptions& options) {
    options.view.threads = 1;
    add_view_options(app, options.view, true);
    app.add_option("--budget", options.budget, "The limits, a TOML file");
    app.add_option("--write", options.write, "Make such a file of this run: what it took, and a margin");
    app.add_option("--margin", options.margin_pct,
                   "Of --write, in percent: of medians, passes and effects; twice that for the 99th percentile, thrice "
                   "for the worst frame, none for work")
        ->check(number_in(0.0, 1e4))
        ->capture_default_str();
    app.add_option("--laps", options.laps, "Laps at least")->check(CLI::Range(1, 10000))->capture_default_str();
    app.add_option("--max-laps", options.max_laps,
                   "Laps at most: as many while a time limit is missed, and for --write")
        ->check(CLI::Range(1, 10000))
        ->capture_default_str();
    app.add_option("--frames", options.max_frames, "Only the first N frames of the walk; 0: all")
        ->check(CLI::Range(0, 1000000));
    app.add_option("--junit", options.junit, "Write a JUnit report, a test case a limit");
    app.add_option("--trace", options.trace, "Write a trace of the last lap (ui.perfetto.dev, chrome://tracing)");
    app.add_option(
        "--keep", options.keep,
        "Folder that a miss leaves the worst frame in: frame.png, plan.txt, trace.json, budget.json; default: "
        "budget-miss, beside the JUnit report");
    app.add_flag("--json", options.json, "Print one JSON object on stdout, every frame included: input of ff report");
    app.footer(R"(The file:
  format = 1
  calibration_ms = 0.91      # as --write measured it; without it times are not scaled
  [time]                     # of a frame, posing what moves included
  median_ms = 9.8
  p99_ms = 13.0
  worst_ms = 15.0
  [passes.cast]              # mean of a frame; names as in ff bench and the overlay
  ms = 4.1
  [effects.sun_shadows]      # likewise; names as in ff stats
  ms = 1.2
  [work]                     # of the frame that takes most; exact, never scaled
  rays = 290000              # rays, triangles, points, texels, pixels, layers, allocations, upload_bytes

With one worker, as here unless --threads says otherwise, times are what its thread has run, not what others took from
it; with more they are by the clock. A frame's time is the least of its laps. Limits of time are multiplied by this machine's calibration, measured before
each frame, over the file's. The first four frames of a lap do not count.

Exit codes: 0 all limits held, 2 usage, 3 bad pack or budget file, 4 a limit missed, 1 anything else.

  ff budget town.ffpack --walk street --write town.budget.toml
  ff budget town.ffpack --walk street --budget town.budget.toml --junit budget.xml)");
}

void add_compare_options(CLI::App& app, CompareOptions& options) {
    app.add_option("RECORDING", options.recording, "A .ffreplay")->required();
    app.add_option("--packs", options.packs,
                   "The two worlds, packs or sources; the first is what the second is held to")
        ->expected(2)
        ->required();
    app.add_option("--until", options.until, "Stop after this tick");
    app.add_option("--laps", options.laps, "Times that the session is replayed; a frame's time is the least of them")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    app.add_option("--out", options.out, "Folder for a.png, b.png and difference.png of the frame that differs most")
        ->capture_default_str();
    app.add_option("--budget-ms", options.budget_ms, "Of drawn frames; 0: exact frames")->check(number_in(0.0, 1e5));
    app.add_flag("--json", options.json, "Print one JSON object on stdout, every frame included: input of ff report");
    add_size_and_threads(app, options.size, options.threads);
    app.footer(
        R"(The session is played in both worlds, 30 frames a second of game time; both are drawn from where the first one's
player stands, in turn, so that nobody is always first. Where the sessions part, because what the player ran into has
changed, the report names the tick.

Exit codes: 0 done, 2 usage, 3 bad recording or pack, 1 anything else.

  ff compare session.ffreplay --packs before.ffpack after.ffpack --out compare)");
}

void add_report_options(CLI::App& app, ReportOptions& options) {
    app.add_option(
           "INPUT", options.inputs,
           "JSON of ff bench --each-frame, ff budget --json, ff replay --bench --each-frame --json, ff compare --json")
        ->required();
    app.add_option("-o,--output", options.output, "The page to write, NAME.html")->required();
    app.footer(
        R"(One file that asks the network for nothing: frame times over the walk with the plan's decisions under them, passes and
effects in time, pixel sources, work, a map of the walk coloured by frame time, the worst frames with pictures and plans,
and how limits were held.

Exit codes: 0 done, 2 usage, 3 an input that is none of these, 1 anything else.

  ff bench town.ffpack --walk street --modes hybrid --each-frame > bench.json
  ff report bench.json -o report.html)");
}

}  // namespace ff::tool
