// The program that controllers with isolation="process" live in.
#include "control/guard.h"

int main() { return cogrsim::guard::run(); }
