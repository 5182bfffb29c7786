#include "engine/host/run_game.h"
#include "game/beacons/beacons_game.h"

int main(int argc, char** argv) {
    return ff::host::run_game(ff::beacons::game_info(), argc, argv);
}
