// SPDX-License-Identifier: Apache-2.0
// What the world lets a board's further channels (channels.h) feel.
#pragma once

// X(channel, what is true in the channel's unit, standard deviation of its noise in that unit), a row a channel; what
// is true at the cell is in `truth`, a `Truth`. A channel without a row reads 0.
#ifndef RS_FURTHER_TRUTH
#define RS_FURTHER_TRUTH(X)
#endif
