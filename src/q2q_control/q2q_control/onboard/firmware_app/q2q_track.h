/* Past motion of a vehicle: what the other files of the app need of it. */
#ifndef Q2Q_TRACK_H
#define Q2Q_TRACK_H

#include "q2q_app.h"

/* Return the time from one stamp to a later one [s]; negative if it is earlier. */
float q2q_seconds(uint32_t from_us, uint32_t to_us);

/* Return whether all numbers of a motion are finite; false, too, for finite ones whose sum is not. */
bool q2q_finite(const struct q2q_motion *motion);

/* Append a sample; return false if it is not later than the last one or not finite. */
bool q2q_remember(struct q2q_track *track, uint32_t stamp_us, const struct q2q_motion *motion);

/* Return whether the last sample is at most Q2Q_STALE_S old, and not later than now. */
bool q2q_heard(const struct q2q_track *track, uint32_t now_us);

/* Empty the tracks of silent vehicles: half the period of the clock later (36 min) their age would be negative,
   and a whole one later they would be new. */
void q2q_forget(struct q2q_app *app, uint32_t now_us);

/* Return the age of the first sample that is left [s]. */
float q2q_oldest(const struct q2q_track *track, uint32_t now_us);

/* Write the motion `age` before now_us: interpolated, dead reckoned beyond the last sample, or the first one. */
void q2q_motion_at(const struct q2q_track *track, uint32_t now_us, float age, struct q2q_motion *out);

/* Write the motion after some time at constant velocity. */
void q2q_motion_after(const struct q2q_motion *motion, float seconds, struct q2q_motion *out);

#endif
