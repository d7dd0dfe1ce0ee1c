// Symbol visibility: everything is hidden unless marked.
#pragma once

#define COGRSIM_API __attribute__((visibility("default")))
