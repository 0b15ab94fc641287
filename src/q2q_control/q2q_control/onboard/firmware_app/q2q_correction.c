/* Residual of the model along z, estimated from measured pushes as in
   q2q_model.downwash.correction.corrected_predictor.

     y = eta + b + r + noise,   r an Ornstein-Uhlenbeck process:   E r^2 = (floor + slope |eta|)^2,  time T */
#include <math.h>

#include "q2q_app.h"

static float left_after(float seconds) { return seconds > 0.0f ? expf(-seconds / Q2Q_RESIDUAL_TIME_S) : 1.0f; }

/* Learn b as the mean of y - eta in clear air, over the last Q2Q_OFFSET_S. */
static void learn_offset(struct q2q_correction *now, float missed, float dt) {
  now->clear_s += dt;
  const float known = now->clear_s > dt ? now->clear_s : dt;
  now->offset += dt / (known < Q2Q_OFFSET_S ? known : Q2Q_OFFSET_S) * (missed - now->offset);
}

void q2q_measure(struct q2q_correction *now, float push, float eta, float dt) {
  const float missed = push - eta;
  const bool good = isfinite(missed);
  if (dt > Q2Q_OLDEST_S) dt = Q2Q_OLDEST_S;
  if (good && dt > 0.0f && fabsf(eta) < Q2Q_CLEAR) learn_offset(now, missed, dt);
  const float share = left_after(dt), size = Q2Q_RESIDUAL_FLOOR + Q2Q_RESIDUAL_SLOPE * (good ? fabsf(eta) : 0.0f);
  now->residual *= share;
  now->variance = share * share * now->variance + (1.0f - share * share) * size * size;
  if (!good) return;
  const float gain = now->variance / (now->variance + Q2Q_RESIDUAL_NOISE * Q2Q_RESIDUAL_NOISE);
  now->residual += gain * (missed - now->offset - now->residual);
  now->variance *= 1.0f - gain;
  now->seen = true;
}

float q2q_residual(const struct q2q_correction *now, float age_s) {
  return now->seen && age_s <= Q2Q_OLDEST_S ? left_after(age_s) * now->residual : 0.0f;
}
