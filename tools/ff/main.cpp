#include "tools/ff/commands.h"

int main(int argc, char** argv) {
    return ff::tool::run(argc, argv);
}
