// The walkthrough's window under a virtual display, moved by real key events.

#include <gtest/gtest.h>

#include "tests/e2e/run_process.h"

namespace ff::test {
namespace {

/// Runs a command on a virtual display of its own, with a cache of this test's.
ProcessResult run_on_display(const std::string& command) {
    return run("XDG_CACHE_HOME=" + (scratch() / "cache").string() +
               " timeout 250 xvfb-run -a -s '-screen 0 800x600x24' " + command);
}

TEST(Window, keys_move_the_camera_and_escape_ends) {
    if (run("command -v xvfb-run && command -v xdotool").exit_code != 0)
        GTEST_SKIP() << "xvfb-run or xdotool is not installed (tools/setup installs both)";
    const auto out = scratch() / "window";
    const auto script = scratch() / "play.sh";
    // F12 saves a picture. The first key takes the camera over, so both pictures are of a camera that stands still.
    write_file(script, R"(set -eu
)" FF_BINARY R"( walk "$1" --window --walk turn --size 320x240 --out "$2" &
tool=$!
wait_for() { for _ in $(seq 600); do [ -e "$1" ] && return; sleep 0.1; done; echo "no $1"; exit 1; }
for _ in $(seq 600); do window=$(xdotool search --onlyvisible --name Farfield | head -1) && [ -n "$window" ] && break; sleep 0.1; done
for _ in $(seq 50); do xdotool windowfocus "$window" && break; sleep 0.1; done  # refused until it is mapped
sleep 1
xdotool key --window "$window" Left
sleep 0.5
xdotool key --window "$window" F12
wait_for "$2/picture1.png"
xdotool keydown --window "$window" w; sleep 1.5; xdotool keyup --window "$window" w
sleep 0.5
xdotool key --window "$window" F12
wait_for "$2/picture2.png"
xdotool key --window "$window" F1
sleep 0.5
xdotool keydown --window "$window" Escape  # no key up: the window is gone by then
wait $tool
)");
    const ProcessResult result =
        run_on_display("bash " + script.string() + " " + hamlet_pack().string() + " " + out.string());
    ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
    const double psnr = psnr_db(out / "picture1.png", out / "picture2.png");
    EXPECT_LT(psnr, 35.0) << "the picture did not change while W was held";
}

TEST(Window, the_game_is_begun_walked_and_left_by_keys_and_its_recording_plays_again) {
    if (run("command -v xvfb-run && command -v xdotool").exit_code != 0)
        GTEST_SKIP() << "xvfb-run or xdotool is not installed (tools/setup installs both)";
    const auto folder = scratch() / "player";
    const auto script = scratch() / "game.sh";
    // Escape pauses; from "Go on", Up goes round to "Quit".
    write_file(script, R"(set -eu
)" FF_BINARY R"( play "$1" --folder "$2" --budget-ms 100 &
tool=$!
for _ in $(seq 600); do window=$(xdotool search --onlyvisible --name Beacons | head -1) && [ -n "$window" ] && break; sleep 0.1; done
for _ in $(seq 50); do xdotool windowfocus "$window" && break; sleep 0.1; done  # refused until it is mapped
sleep 3
xdotool key --window "$window" Return
for _ in $(seq 300); do [ -e "$2/recordings/beacons-1.ffreplay" ] && break; sleep 0.1; done
sleep 1
xdotool keydown --window "$window" w; sleep 2; xdotool keyup --window "$window" w
sleep 0.5
xdotool key --window "$window" Escape
sleep 1.5
xdotool key --window "$window" Up
sleep 1
xdotool keydown --window "$window" Return  # no key up: the window is gone by then
wait $tool
)");
    const ProcessResult result =
        run_on_display("bash " + script.string() + " " + hamlet_pack().string() + " " + folder.string());
    ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
    const ProcessResult replay =
        run_ff("replay " + (folder / "recordings/beacons-1.ffreplay").string() + " --verify --json");
    ASSERT_EQ(replay.exit_code, 0) << replay.err;
    EXPECT_NE(replay.err.find("every tick as recorded"), std::string::npos) << replay.err;
    // Two seconds of walking are metres away from the spawn point.
    EXPECT_EQ(replay.err.find(", 0.0), "), std::string::npos) << replay.err;
    EXPECT_NE(replay.out.find("\"closed\": true"), std::string::npos) << replay.out;
}

TEST(Window, a_changed_source_is_swapped_in_and_a_broken_one_is_not) {
    if (run("command -v xvfb-run && command -v xdotool").exit_code != 0)
        GTEST_SKIP() << "xvfb-run or xdotool is not installed (tools/setup installs both)";
    const auto source = scratch() / "source";
    std::filesystem::copy(FF_SOURCE_DIR "/tests/content/hamlet", source);
    std::filesystem::copy(FF_SOURCE_DIR "/engine/shaders", scratch() / "shaders");
    const auto script = scratch() / "reload.sh";
    write_file(script, R"(set -u
)" FF_BINARY R"( play "$1/hamlet.toml" --folder "$1/player" --skip-title --budget-ms 100 --shaders "$2" 2> "$1/log" &
tool=$!
wait_for() { for _ in $(seq 600); do grep -q "$1" "$3/log" && return; sleep 0.1; done; echo "no $1 after $2"; cat "$3/log"; kill $tool; exit 1; }
for _ in $(seq 600); do [ -e "$1/player/recordings/beacons-1.ffreplay" ] && break; sleep 0.1; done
sleep 1
printf '\n[[place]]\nname = "beacon.2"\nposition_m = [9.0, 0.0, 0.0]\n' >> "$1/hamlet.toml"
wait_for "the world was changed; its things too" "another beacon" "$1"
sed -i 's/roof = "gabled"/roof = "flat"/' "$1/hamlet.toml"
wait_for "the world was changed$" "another roof" "$1"
sed -i 's/roof = "flat"/roof = "thatched"/' "$1/hamlet.toml"
wait_for "hamlet.toml.*thatched" "a broken roof" "$1"
echo "no GLSL" >> "$2/view.glsl"
wait_for "no GLSL" "a broken shader" "$1"
kill -0 $tool || { echo "the game has ended"; exit 1; }
window=$(xdotool search --onlyvisible --name Beacons | head -1)
xdotool windowfocus "$window"; sleep 0.5
xdotool key --window "$window" Escape; sleep 1.5
xdotool key --window "$window" Up; sleep 1
xdotool keydown --window "$window" Return
wait $tool
)");
    const ProcessResult result =
        run_on_display("bash " + script.string() + " " + source.string() + " " + (scratch() / "shaders").string());
    EXPECT_EQ(result.exit_code, 0) << result.out << result.err << read_file(source / "log");
}

TEST(Window, the_game_is_won_by_keys_and_mouse_from_title_to_end) {
    if (run("command -v xvfb-run && command -v xdotool && command -v ffmpeg").exit_code != 0)
        GTEST_SKIP() << "xvfb-run, xdotool or ffmpeg is not installed (tools/setup installs them)";
    const auto folder = scratch() / "winner", pictures = scratch() / "pictures";
    const ProcessResult result =
        run_on_display(std::string(WINDOW_PLAYER) + " " + FF_BINARY + " " + hamlet_pack().string() + " " +
                       folder.string() + " " + pictures.string() + " 120");
    ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
    // Between them may lie others, of the spyglass and of what was lit, as time allowed.
    bool has_end = false;
    for (const auto& entry : std::filesystem::directory_iterator(pictures))
        has_end |= entry.path().filename().string().find("-end.png") != std::string::npos;
    EXPECT_TRUE(has_end);
    EXPECT_LT(psnr_db(pictures / "00-title.png", pictures / "01-begun.png"), 40.0);
    EXPECT_EQ(run_ff("replay " + (folder / "recordings/beacons-1.ffreplay").string() + " --verify").exit_code, 0);
}

}  // namespace
}  // namespace ff::test
