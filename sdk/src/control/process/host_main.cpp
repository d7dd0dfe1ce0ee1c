// The program that runs controllers with isolation="process".
#include "control/process/controller_host.h"

int main(int, char** arguments) { return cogrsim::run_controller_host(arguments + 1); }
