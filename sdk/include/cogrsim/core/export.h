// Symbol visibility: every symbol is hidden unless it is marked with COGRSIM_API.
#pragma once

#define COGRSIM_API __attribute__((visibility("default")))
