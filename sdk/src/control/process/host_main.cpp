// The program that runs controllers with isolation="process".
#include "control/process/controller_host.h"

int main() { return cogrsim::run_controller_host(); }
