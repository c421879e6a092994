// A reduced image with its tracked points (stillarm/panel/live/view.py).

const HEAD_AT = 4;

// Returns the number of the frame.
export async function drawView(buffer, canvas) {
  const length = new DataView(buffer).getUint16(2, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, HEAD_AT, length)));
  const image = await createImageBitmap(new Blob([new Uint8Array(buffer, HEAD_AT + length)], { type: "image/jpeg" }));
  canvas.hidden = false;
  canvas.width = image.width;
  canvas.height = image.height;
  const context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  context.lineWidth = 1.5;
  for (const [x, y] of head.points) {
    context.strokeStyle = "#000";
    context.strokeRect(x - 3.5, y - 3.5, 7, 7);
    context.strokeStyle = "#ffd21f";
    context.strokeRect(x - 2.5, y - 2.5, 5, 5);
  }
  return head.frame;
}
