// What the page says to the server that it came from. Long work is a job: it reports how far it is, and can be stopped.

/** The answer to a request; throws what was wrong in words. */
export async function ask(action, body = {}) {
  const response = await fetch(action, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(body),
  });
  const answer = await response.json();
  if (!response.ok) throw new Error(answer.error);
  return answer;
}

/** A question that may be asked again before it is answered: only the answer to the last asking counts, others are undefined. */
export function question(action) {
  let last = 0;
  return async (body) => {
    const turn = ++last;
    try {
      const answer = await ask(action, body);
      return turn === last ? answer : undefined;
    } catch (error) {
      if (turn === last) throw error;
      return undefined;
    }
  };
}

const pause = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** Follows the job that runs until its end; `show(status)` is called on the way. Its result; throws its error. */
export async function follow(show) {
  for (let wait = 30; ; wait = Math.min(250, 1.1 * wait)) {
    const status = await ask("progress");
    show(status);
    if (!status.running) {
      if (status.error) throw new Error(status.error);
      return status.result;
    }
    await pause(wait);
  }
}

export async function work(job, body, show) {
  show(await ask(job, body));
  return follow(show);
}

export const stopWork = () => ask("stop");
