// The program that runs controllers with isolation="process".
#include "simulation/controllers/controller_host.h"

int main() { return cogrsim::run_controller_host(); }
